"""Vehicle-track model of a level crossing: one rail on ballast track and embedded in slabs, one wheel."""
