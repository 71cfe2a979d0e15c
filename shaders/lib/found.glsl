// The search before a contact of scm: for the number of posts in the contact patch (PATCH), and for the equilibrium height
// (LOAD). A try sums over the posts. Each invocation of the next try computes the next height from these sums.
// Heights are fixed-point units above the prescribed one.

struct attempt {
	// the bracket: the soil carries the load at `low`, or the object may not sink deeper; it does not carry the load at `high`
	int low, high;
	int top, at;    // height of the first contact; height of this try
	uint gap;       // of try 0: the height of the first contact, + 2^31; 0: none
	uint posts;     // touched posts
	uint force[2];  // force that the soil bears, in 2^-26 of the load
	uint stiff[2];  // how this grows for each fixed-point unit of sinkage
	uint done;      // `at` is the equilibrium height
	uint spare;
};
layout(std430, binding = 2) restrict buffer attempts {
	attempt tries[];
};

float found_real(uint low, uint high)
{
	return float(int(high)) * 4294967296.0 + float(low);
}

// Try `k`, computed from the one before it. Try 0 is at the prescribed height.
attempt found_next(int k, int depth)
{
	attempt b = tries[max(k - 1, 0)];
	attempt a;
	// Try 1 is at the guess, if that is in the ground.
	int top = k <= 1 ? int(b.gap ^ 0x80000000u) : b.top;
	float share = found_real(b.force[0], b.force[1]) * exp2(-26.0), grows = found_real(b.stiff[0], b.stiff[1]) * exp2(-26.0);
	bool carries = share >= 1.0;
	int low = k <= 1 ? top - depth : carries ? b.at : b.low, high = k <= 1 ? top : carries ? b.high : b.at;
	// Force is about a power of depth, so this is Newton's step for the logarithms.
	float z = float(top - b.at), power = clamp(z * grows / max(share, 1e-6), 0.1, 1e6);
	float step = z * exp2(clamp(-log2(max(share, 1e-6)) / power, -20.0, 20.0));
	int next = top - int(round(min(step, float(depth))));
	// If the bracket shrinks too slowly, it is halved. So the last try leaves one fixed-point unit.
	int width = high - low;
	bool lags = width > (depth >> clamp(k - 6, 0, 31)) || share <= 1e-6;
	next = lags ? low + width / 2 : next;
	next = clamp(k <= 1 ? 0 : next, low + 1, max(high - 1, low + 1));
	bool there = k > 1 && abs(share - 1.0) < 2e-6;
	bool none = k <= 1 ? b.gap == 0u : b.done != 0u; // no ground below it, or found before
	a.top = top;
	a.low = low;
	a.high = high;
	a.at = k == 0 ? 0 : none || there ? (k <= 1 ? 0 : b.at) : width <= 1 ? low : next;
	a.done = uint(none || there || width <= 1);
	return a;
}

// 1 / b of a patch of so many posts of this area, m2. At least one post is counted.
float found_by_width(uint posts, float area)
{
	return inversesqrt(max(float(posts), 1.0) * area * 0.31830989);
}
