"""Files and options become a scene.

scene          A scene: wavebands, how many photons each gets, where they enter, what shines; and how it becomes a plan
weather_scene  The whole light of a place and an hour: beam and Perez sky in their shares, without files of AMC
read/          The AOMC files and sky.toml become a scene.
light/         The light of a scene: which inputs of sky and sun win, and what they mean.
embedding      What a C or Fortran program asks of the Python that it started: a scene, then its bands
"""
