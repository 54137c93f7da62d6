"""How good a map is: pure numpy."""
