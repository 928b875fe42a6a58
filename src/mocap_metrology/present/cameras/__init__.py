"""Tables and figure of a group whose subsets of cameras show which one adds noise."""
