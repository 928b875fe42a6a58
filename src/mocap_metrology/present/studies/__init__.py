"""Studies of J's claims: tables, text and figures."""
