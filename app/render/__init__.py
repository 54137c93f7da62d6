"""Maps as pictures and as meshes for other viewers."""
