"""The light of a scene: which inputs of sky and sun win, and what they mean.

inputs          Which inputs of the Perez sky and of the sun win, and the shares of beam and sky that they give
spectral_split  Beam and sky of each waveband from broadband irradiances, by cloudless spectra of SPCTRL2
weather         When and where the sun shines, or an hour of a weather file: what either says of sun and sky
sun_position    Where the sun stands, and how much it gives outside the atmosphere: pvlib's numbers in our conventions
"""
