"""The tables of a library: rows of instances, and LanceDB, which keeps them."""
