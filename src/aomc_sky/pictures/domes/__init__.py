"""Where the values of a picture come from.

source      Domes of the wavebands of a source, on patches that can be drawn
background  Background skies at one wavelength, at one time or many
lobe_share  Lobes in pictures: shares of patches, where they are, and how wide
marks       Sun, beam and narrow lobes as marks
"""
