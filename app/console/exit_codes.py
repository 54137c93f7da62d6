"""Exit codes of the program; 0 is done, 1 an error nobody foresaw."""

BAD_INPUT = 2
INTERRUPTED = 130
