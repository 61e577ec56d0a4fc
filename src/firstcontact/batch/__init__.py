"""Many questions at once: in columns, on every core, on a cluster, from files.

questions   what is asked: bodies, each once, and for each question two of them, their motions and a span
culling     what boxes alone tell to be apart
part        answers to a part of the questions, in this process
together    those about one pair of polyhedra under many motions
workers     parts handed to threads, processes or a cluster, and put together again
processes   those of this machine
verb        `first_contacts`, `many_contact_intervals`
cluster     workers of dask.distributed
results     full results one after the other, for the command
arrow       tables as pyarrow has them, Parquet
files       queries from a file, answers to a file, kept part by part
courses     the first contacts along a long course, part by part

    query_files, query_rows     what is read, and what it asks
    kept_parts, answer_files    what is finished, and where it goes
"""
