// A part of a window of a batch: its posts on one tile. Fragments are posts of the layer in which windows lie.
// Define: PASSED

flat in ivec4 passed[PASSED]; // from batch.vert
ivec4 posts = passed[0]; // those of the part, in the layer: first, one behind the last
ivec4 tile = passed[1];  // x, y: from a post in the layer to that in the tile; its layers in the arrays of bases and of planes, or -1

bool in_part(ivec2 post)
{
	return all(greaterThanEqual(post, posts.xy)) && all(lessThan(post, posts.zw));
}
