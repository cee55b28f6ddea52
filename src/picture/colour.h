/* Colour spaces as matrices, in double. */
#ifndef HDR_COLOUR_H
#define HDR_COLOUR_H

#include "base/base.h"

extern const hdr_chromaticities hdr_rec709;
extern const hdr_chromaticities hdr_cie_xyz; /* X, Y and Z themselves as primaries; white where they are equal */

extern const hdr_chromaticities hdr_aces_ap0, hdr_aces_ap1; /* SMPTE ST 2065-1:2012; Academy S-2014-004 */
extern const hdr_chromaticities hdr_p3_d65;                 /* SMPTE EG 432-1:2010 */
extern const hdr_chromaticities hdr_rec2020;                /* ITU-R BT.2020-2 */

/* True where some coordinate differs by more than 1e-5. */
bool hdr_chromaticities_differ(const hdr_chromaticities *a, const hdr_chromaticities *b);

/* Weights of luminance: 0.2126 0.7152 0.0722 for Rec.709, else the Y row of RGB to XYZ with white at Y = 1. False if
 * the primaries span no triangle. */
bool hdr_luminance_weights(const hdr_chromaticities *primaries, double weights[3]);

/* Whether the primaries are X, Y and Z themselves, whatever is said of white. */
bool hdr_primaries_are_xyz(const hdr_chromaticities *primaries);

/* RGB of these primaries to linear Rec.709, m by rows. Unless adapt is false or the primaries are those of XYZ itself,
 * white is adapted from neutral (x, y) to D65 by Bradford. False if the primaries span no triangle. */
bool hdr_matrix_to_rec709(const hdr_chromaticities *primaries, const double neutral[2], bool adapt, double m[9]);

/* RGB of these primaries to XYZ with white at Y = 1, m by rows; exactly the identity for hdr_cie_xyz. False if the
 * primaries span no triangle. */
bool hdr_matrix_to_xyz(const hdr_chromaticities *primaries, double m[9]);

#endif
