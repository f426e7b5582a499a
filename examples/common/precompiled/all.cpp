// Nothing but a reason to compile the library and CLI11 once.
