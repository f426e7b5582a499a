# Stands in for an Eigen of another version, -D PRETENDED_EIGEN=..., whose headers are not here to be had.
add_library(Eigen3::Eigen INTERFACE IMPORTED)
