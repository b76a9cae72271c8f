"""Files from which the AOMC program launches our photon counts.

degree_counts  Photon counts on whole degrees, the only directions in its sky file, or reasons against them
skydist        A skydist.inp from which the unmodified AOMC 1.2.2 program launches exactly our counts, and its folder
"""
