"""Allan variances of sampled series, and how sure they are."""
