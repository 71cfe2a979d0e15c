// The parameters of one terrain draw, or of the sky: struct picture_params in src/render/internal.h.
layout(std140, binding = 0) uniform picture {
	mat4 project;     // metres relative to the eye, store axes, to clip space
	vec4 right, up, forward; // the camera's axes; right and up scaled to the picture's edge; right.w: a pixel's angle
	vec4 sun;         // direction to it
	vec4 haze;        // extinction per metre at the eye, 1 / its scale height, metres; eye above low
	vec4 relief;      // lowest height, 1 / relief, how much of a mountain it is, height of the eye; metres
	vec4 origin;      // the tile's south-west post relative to the eye; spacing; the eye above its lattice height
	vec4 pattern;     // the tile's south-west post modulo the ground pattern's period, metres; metres a post; log2 of a pixel's angle
	vec4 corner_squares; // the same post in the ground's textures: near, far
	vec4 ground;      // its post in the level-0 tile, level-0 posts a post, level-0 spacing
	vec4 detail;      // by radii: metres of distance a metre between vertices; where tiles stand in, a skirt's depth, metres; as the
	                  // first, where vertices are near enough to show ruts; how far off ground may be drawn, a metre of distance
	vec4 sunlight;    // its light; w: the sky's, beside that by day
	vec4 tint;        // of the sky on the sun's side and round it
	vec4 soils[16];   // how each class of the map looks beside what it is like; w: what that is, a layer of the textures
	ivec4 tile;       // cells, first instance, the eye's lattice height / 2, cells along a block
	vec4 layer;       // what colours tell, as enum render_layer_kind; their range's low end, 1 / its width; 2 x level, + 1 of every other tile
#ifdef REACHES
	vec4 reaches[3];  // distances from which on strides of 2^0, 2^1 ... do; none is less than the one before
#endif
};

const float half_base_metre = 1.0 / 131072.0; // metres of half a base height, 2^-17
const float base_metre = 1.0 / 262144.0;      // of a base height, 2^-18
const float offset_metre = 1.0 / 1048576.0;   // of an offset, 2^-20
// Where vertices are at most so far apart, in metres, the mesh is made to show ruts (src/render/camera.c has the same value).
#define RUT_CELL 0.3
