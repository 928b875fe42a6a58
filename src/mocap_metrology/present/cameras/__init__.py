"""Tables and figure of a group whose subsets of cameras tell which one adds noise."""
