"""Every sentence about a result, made from its codes and numbers."""
