/* Gaussians that are integrated over each pixel. */
#ifndef HDR_GAUSSIAN_H
#define HDR_GAUSSIAN_H

/* weight[k] = the integral of the Gaussian of standard deviation sigma from k - 1/2 to k + 1/2, k = 0 ... reach, each
 * right to some 2^-53 z^2 of itself, z standard deviations away; then divided by their sum over -reach ... reach. */
void hdr_gaussian(double sigma, int reach, double *weight);

/* The least reach, no less than `deviations` standard deviations, for which no more than `rest` of the Gaussian's mass
 * lies outside. */
int hdr_gaussian_reach(double sigma, double deviations, double rest);

#endif
