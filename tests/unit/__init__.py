"""One file a module, in the folders of the packages."""
