"""Here so that pytest finds the modules of this folder from the folders below it, too."""
