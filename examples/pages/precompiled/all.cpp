// Holds nothing: its target makes the precompiled header of the pages' programs.
