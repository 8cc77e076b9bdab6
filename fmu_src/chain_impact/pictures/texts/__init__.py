"""The words of pictures: the headline with the conditions below it, names of points, numbers of impacts."""
