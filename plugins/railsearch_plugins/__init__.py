"""Built-in plugins of railsearch, registered through the same hooks as any other."""
