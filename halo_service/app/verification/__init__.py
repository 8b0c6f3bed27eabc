"""`halo verify`: touch a projected grid and measure the error."""
