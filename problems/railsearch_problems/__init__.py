"""Design problems that come with railsearch."""
