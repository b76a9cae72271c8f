"""Phase functions as triples sample / pdf / cdf, and the scattering step that uses them."""
