"""Tables and figures of Skurowski & Pawlyta 2019 (S): theory and Gaussian model."""
