"""Board poses and the pose of the slave: the algorithm of J, its peers, and variants."""
