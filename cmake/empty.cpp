// A module without sources of its own is a library all the same.
