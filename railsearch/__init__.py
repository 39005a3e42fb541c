"""railsearch: search for better railway transition zones on a budget of expensive simulations."""
