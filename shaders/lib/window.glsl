// Shared by the passes over a window: special values and bits of its planes.

const int BASE_NODATA = int(0x80000000u);
const int UNDER_NONE = 0x7fffffff;  // the object is not above the post
const int OFFSET_LIMIT = 1 << 30;   // fixed-point units: 1024 m
const int TOUCH = 4;                // fixed-point units; the envelopes of a motion and of its end pose are rounded separately
// Bits of `contacts`. A post that has neither LOWERED nor HELD can take soil. NEAR: the object was less than two spacings above the post,
// so it may have left it.
const uint LOWERED = 1u, HELD = 2u, TOUCHED_POST = LOWERED | HELD, NEAR = 16u;
const uint NO_GROUND = 32u; // in `contacts` after a contact: the post has no data
const uint CRAMPED = 64u; // in `contacts`: a body at rest leaves little room above the post, so no soil is laid there
const uint CLOSED = 8u; // over blocks, in `contacts`: the post's block is not visited, so the post does not relax
