"""Errors of a system that has no room left, or lets nothing be written: no fault of the program, said in one line."""

from __future__ import annotations

from errno import EDQUOT, EFBIG, EIO, EMFILE, ENAMETOOLONG, ENFILE, ENOMEM, ENOSPC, EROFS

NO_ROOM = (EDQUOT, EFBIG, EIO, EMFILE, ENAMETOOLONG, ENFILE, ENOMEM, ENOSPC, EROFS)
