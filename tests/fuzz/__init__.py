"""Random changes of the files that are read: each has to end in a value or in one plain line."""
