// What the search before a contact of scm found (deform/scm_find.comp).

// States of a loaded object.
const uint CARRIED = 0u;
const uint SLIDES = 1u; // carried, but its weight along the slope is more than the soil can hold by shear
const uint SUNK = 2u;   // nothing carries it
const uint AIR = 3u;    // there is no ground under it

struct found_state {
	int raised;  // the equilibrium height above the prescribed one, fixed-point units
	uint posts;  // posts that the object touches at that height
	uint state;
	// The share of the load that the soil carries at that height. It is not quite 1, since heights are whole units. At the exact
	// height, a fraction of a unit away, all stresses are smaller by about this factor.
	float share;
	int before;  // the height that the last contact of this object found; 0: none is kept
};

layout(std430, binding = 2) restrict buffer finds {
	found_state founds[]; // one for each window of a batch; otherwise one
};
#define FOUND founds[WINDOW]

// 1 / b of a patch of so many posts of this area, m2. At least one post is counted.
float found_by_width(uint posts, float area)
{
	return inversesqrt(max(float(posts), 1.0) * area * 0.31830989);
}
