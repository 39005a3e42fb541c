"""Public optimisers as railsearch strategies, each in an environment of its own."""
