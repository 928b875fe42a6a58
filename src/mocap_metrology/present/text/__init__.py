"""What is said: every sentence about a result, made of its codes and numbers."""
