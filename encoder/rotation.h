/* The rotation in a linear map. */
#ifndef NSDF_ROTATION_H
#define NSDF_ROTATION_H

/* Brings the rotation r[9] towards the orthogonal factor of a[9], both row by row, in up to 20 steps from where it is
 * (Mueller, Bender, Chentanez, Macklin 2016).  A start near the answer finds it in a few steps. */
void nsdf_extract_rotation(const double a[9], double r[9]);

#endif
