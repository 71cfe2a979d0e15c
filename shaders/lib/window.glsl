// What the passes over a window share: the words of its planes.

const int BASE_NODATA = int(0x80000000u);
const int UNDER_NONE = 0x7fffffff;  // the object is not above the post
const int OFFSET_LIMIT = 1 << 30;   // fixed-point units: 1024 m
const int TOUCH = 4;                // fixed-point units; a contact and its end are rounded apart
const uint LOWERED = 1u, HELD = 2u, HOLE = 4u; // contacts; HOLE: no data, so that 0 is free
