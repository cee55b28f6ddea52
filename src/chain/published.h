/* Transfer curves as they are published, in long double, for the cross-check alone: nothing here is shared with the
 * verbs, whose constants and arithmetic it is to prove. And the formulas that OpenColorIO follows where it is known to
 * deviate from what is published. */
#ifndef HDR_PUBLISHED_H
#define HDR_PUBLISHED_H

typedef long double (*hdr_published)(long double value);

/* C^(1/2.2), IEC 61966-2-1, BT.709, ST 2084 with 1.0 at 100 cd/m2, BT.2100's HLG: to encoded, and back. */
long double hdr_published_gamma(long double c);
long double hdr_published_gamma_back(long double v);
long double hdr_published_srgb(long double c);
long double hdr_published_srgb_back(long double v);
long double hdr_published_rec709(long double c);
long double hdr_published_rec709_back(long double v);
long double hdr_published_pq(long double c);
long double hdr_published_pq_back(long double v);
long double hdr_published_hlg(long double c);
long double hdr_published_hlg_back(long double v);

/* The same as OpenColorIO 2.1 has them. */
long double hdr_ocio_gamma(long double c);
long double hdr_ocio_gamma_back(long double v);
long double hdr_ocio_srgb(long double c);
long double hdr_ocio_srgb_back(long double v);
long double hdr_ocio_rec709(long double c);
long double hdr_ocio_rec709_back(long double v);
long double hdr_ocio_pq(long double c);
long double hdr_ocio_pq_back(long double v);

#endif
