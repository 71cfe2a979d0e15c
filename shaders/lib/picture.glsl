// The parameters of one draw of a tile, of objects, or of the sky: struct picture_params in src/render/internal.h, filled by
// src/render/frame.c and body.c. Directions and places are in the store's axes (x east, y north, z up), places relative to the eye.
layout(std140, binding = 0) uniform picture {
	mat4 project;     // from a place in metres to clip space
	vec4 right, up, forward; // xyz: axes of the camera; right and up reach to the picture's edge; right.w: angle of a pixel, rad
	vec4 sun;         // xyz: direction to the sun; w: exposure less 1
	vec4 haze;        // x: extinction at the eye, 1/m; y: 1 / scale height, 1/m; z: height of the eye above the lowest ground, m
	// x: lowest height, m; y: 1 / relief, 1/m; z: 0 .. 1, from a relief of hills to one of mountains; w: height of the eye, m
	vec4 relief;
	// xy: the tile's south-west post; z: spacing; w: height of the eye above its lattice height (tile.z); metres
	vec4 origin;
	// xy: the tile's south-west post modulo the period of the ground's pattern, m; z: spacing, m; w: log2 of a pixel's angle
	vec4 pattern;
	vec4 corner_squares; // the tile's south-west post in the ground's textures, in repeats: xy near texture, zw far texture
	vec4 ground;      // xy: the tile's south-west post in its level-0 tile, in level-0 posts; z: level-0 posts per post; w: level-0 spacing
	// Without a pixel error: x: reach of a stride (src/render/camera.c), per metre between vertices; z: the same where vertices are
	// near enough to show ruts. y: least depth of a skirt, m; 0 if every tile is as fine as selected. w: allowed error of the ground's
	// height, per metre of distance.
	vec4 detail;
	vec4 sunlight;    // rgb: light of the sun; w: light of the sky relative to that at noon
	vec4 tint;        // rgb: factor for the colour of the sky around the sun
	vec4 soils[16];   // for each soil class of the map: rgb: tint; w: layer of the ground's textures (src/render/body.c)
	ivec4 tile;       // x: cells of a tile; y: first instance; z: the eye's lattice height, in units of 2 base units; w: cells of a block
	// With IMAGERY. y: log2 of metres between pixels of the finest imagery. z: levels from it to the finest of the draw's table. w: levels from
	// there to the coarsest of the table. Otherwise false colours. x: enum render_layer_kind; y: low end of its range; z: 1 / width of the range. w: 2 * (level - TILE_LEVEL_MIN), plus
	// 1 for every other tile, as on a chessboard.
	vec4 layer;
#ifdef REACHES
	vec4 reaches[3];  // for the strides 2^0, 2^1, ...: from which distance from the eye, m, each is fine enough; they never fall
#else
	vec4 no_reaches[3];
#endif
	// Maps of shadows (src/render/shade_map.c). xyz: the maps' axes, of which the third is the sun
	vec4 shade_across, shade_along;
	// xyz: the middle of each map along these axes, m; w: the value of that depth
	vec4 shade_middle[4];
	vec4 shade_scale[4]; // xyz: from metres along these axes to -1 .. 1 and depth; w: size of a texel, m
#if defined HEALS || defined VEGETATION
	ivec4 marks;    // quarter seconds: the store's time; what marks take to heal, to rise, to grow
	vec4 plants;    // x: height, m
	vec4 cover[4];  // for each soil class, the share of the ground that plants cover
#endif
#ifdef IMAGERY
	// Two vectors for each level of the draw's table. The first has x: pixels of the level for each post of the tile. yz: the tile's south-west
	// post, in pixels of its page. w: where the pages begin. The second has the first and the last page, from south-west to north-east.
	layout(offset = 864) vec4 imagery_levels[64];
#endif
};

const float half_base_metre = 1.0 / 131072.0; // metres in two units of a base height, 2^-17
const float base_metre = 1.0 / 262144.0;      // metres in a unit of a base height, 2^-18
const float offset_metre = 1.0 / 1048576.0;   // metres in a fixed-point unit of an offset, 2^-20
// Where vertices are at most so far apart, in metres, the mesh is made to show ruts (src/render/camera.c has the same value).
#define RUT_CELL 0.3
