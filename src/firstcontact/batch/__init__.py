"""Many questions at once: in columns, on every core, on a cluster, from files.

questions   what is asked: bodies, each once, and for each question two of them, their motions and a span
part        answers to a part of the questions, in this process
workers     parts handed to threads, processes or a cluster, and put together again
verb        `first_contacts`
arrow       tables as pyarrow has them, Parquet
"""
