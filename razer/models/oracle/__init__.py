"""Models that know the truth, with as much noise as asked for."""
