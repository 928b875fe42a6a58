"""What noise, lighthouse and c3d share: refusals, whole files, Parquet, compiled kernels."""
