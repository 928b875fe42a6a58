"""How good an optical tracking system is, from the recordings it makes."""
