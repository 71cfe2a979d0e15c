// Distances along a row to the nearest touched post in it. They are used if carried soil goes around the patch.
// Include it after the image `contacts`.

layout(binding = 7, r32i) restrict uniform iimage2DArray ways; // posts

// Finds the distances of the posts from x = first to before x = last.
void store_ways(int y, int layer, int first, int last)
{
	int way = NO_WAY;
	for (int x = first; x < last; x++) {
		way = (imageLoad(contacts, ivec3(x, y, layer)).r & TOUCHED_POST) != 0u ? 0 : min(way + 1, NO_WAY);
		imageStore(ways, ivec3(x, y, layer), ivec4(way));
	}
	way = NO_WAY;
	for (int x = last - 1; x >= first; x--) {
		int before = imageLoad(ways, ivec3(x, y, layer)).r;
		way = before == 0 ? 0 : min(way + 1, NO_WAY);
		if (way < before)
			imageStore(ways, ivec3(x, y, layer), ivec4(way));
	}
}
