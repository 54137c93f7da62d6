"""Error profiles of the oracle models: masks and vectors that err as those of one kind of real model do."""
