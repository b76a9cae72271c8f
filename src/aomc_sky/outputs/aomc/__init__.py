"""Files from which the AOMC program launches our photon counts.

degree_counts  Photon counts on whole degrees, the only directions that its sky file knows, or why there are none
skydist        A skydist.inp from which the unmodified AOMC 1.2.2 program launches exactly our counts, and its folder
"""
