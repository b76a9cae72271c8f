"""Every jitted function of the package. Numbers and arrays only: no sky, no file, no option."""
