"""Many questions at once: in columns, on every core, on a cluster, from files.

questions   what is asked: bodies, each once, and for each question two of them, their motions and a span
part        answers to a part of the questions, in this process
workers     parts handed to threads, processes or a cluster, and put together again
verb        `first_contacts`
cluster     workers of dask.distributed
arrow       tables as pyarrow has them, Parquet
files       queries from a file, answers to a file, kept part by part

    query_files, query_rows     what is read, and what it asks
    kept_parts, answer_files    what is finished, and where it goes
"""
