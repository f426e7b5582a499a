// Holds nothing: its target makes the precompiled headers of the tests.
