"""Files and options become a scene.

scene          A scene: wavebands, photons of each, where they enter, and light; and how it becomes a plan
importance     The importance of patches as a caller gives it: one number for each patch of a component
masses         The masses of a scene's components as a plan has them, and what cannot be shared out
weather_scene  The whole light of a place and an hour: beam and sky in their shares, without files of AMC
irradiances    Beam and sky on a horizontal plane at many times, without photons
read/          The AOMC files and sky.toml become a scene.
light/         The light of a scene: which inputs of sky and sun win, and what they mean.
"""
