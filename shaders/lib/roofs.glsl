// How high soil may bring posts below bodies at rest (src/soil/sliding/roofs.h).

const int ROOF_NONE = 0x7fffffff;

#ifdef BLOCKS
layout(binding = 3, r32i) readonly uniform iimage2DArray roofs; // the highest offset to which soil may bring a post; ROOF_NONE: any
#elif defined PASSED
layout(binding = 6, r32i) readonly uniform iimage2DArray roofs;
#else
layout(binding = 1, r32i) readonly uniform iimage2DArray roofs;
#endif

#ifdef PASSED
// Returns how much soil a post takes from a neighbour at most: an eighth of the room that is left. So one iteration cannot bring it above the roof.
int room_below_roof(ivec3 at, int height)
{
	int highest = imageLoad(roofs, at).r;
	int room = int(uint(imageLoad(grounds, at).r) * 4u + uint(highest) - uint(height)) >> 3;
	return highest == ROOF_NONE ? 1 << 27 : max(room, 0);
}
#endif
