/* furrow explain: what a scene has beside ruts, and what that costs: soil aboard bodies and in the air, marks on the ground. */
#include <stdio.h>
#include <string.h>

#include "explain.h"
#include "explain_layout.h"
#include "scene/scene.h"

/* Bytes of a buffer that is made once. */
static uint64_t bytes_of(const struct plan *plan, const char *name)
{
	uint64_t bytes = 0;
	for (size_t i = 0; i < plan->count; i++)
		if (plan->lines[i].kind == PLAN_BUFFER && plan->lines[i].unit == PLAN_ONCE && strcmp(plan->lines[i].name, name) == 0)
			bytes += plan->lines[i].bytes;
	return bytes;
}

/* Bytes that an effect keeps at each post. */
static uint64_t post_bytes(const struct plan *plan, const char *effect)
{
	uint64_t bytes = 0;
	for (size_t i = 0; i < plan->count; i++)
		if (plan->lines[i].kind == PLAN_PLANE && plan->lines[i].effect != NULL && strcmp(plan->lines[i].effect, effect) == 0)
			bytes += plan->lines[i].bytes;
	return bytes;
}

static void begin(bool *begun)
{
	if (!*begun)
		puts("\nbeside ruts");
	*begun = true;
}

/* Adds a name to a list of three at most. */
static void add_name(char names[200], size_t *count, const char *vehicle, const char *name)
{
	if ((*count)++ < 3)
		snprintf(names + strlen(names), 200 - strlen(names), "%s%.30s%s%.30s", *count > 1 ? ", " : "", vehicle, vehicle[0] != '\0' ? "." : "", name);
}

static void print_aboard(const struct scene *scene, const struct report_plan *plan, bool *begun)
{
	const uint64_t bytes = bytes_of(&plan->plan, "soil aboard bodies");
	char text[400], names[200] = "";
	size_t carrying = 0;
	for (size_t i = 0; i < scene->object_count; i++)
		if (scene->objects[i].carry)
			add_name(names, &carrying, "", scene->objects[i].name);
	for (size_t i = 0; i < scene->vehicle_count; i++)
		for (size_t k = 0; k < scene->vehicles[i].carry.count; k++)
			add_name(names, &carrying, scene->vehicles[i].name, scene->vehicles[i].carry.list[k]);
	if (carrying == 0)
		return;
	begin(begun);
	if (carrying > 3)
		snprintf(names + strlen(names), sizeof names - strlen(names), " and %zu more", carrying - 3);
	snprintf(text, sizeof text, "carry: soil stays aboard %s%s%s. It settles after each contact, and for each %g s of simulated time while it moves", names,
		 bytes > 0 ? ": " : "", bytes > 0 ? layout_bytes(bytes).text : "", scene->interval);
	layout_wrapped(text, 4);
}

static void print_effect(const struct report_plan *plan, enum scene_effect effect, const char *what, uint64_t bytes, const char *each, bool *begun)
{
	char text[400];
	if ((plan->effects >> effect & 1) == 0)
		return;
	begin(begun);
	snprintf(text, sizeof text, "%s: %s%s", what, layout_bytes(bytes).text, each);
	layout_wrapped(text, 4);
}

void explain_beside_text(const struct scene *scene, const struct report_plan *plan)
{
	static const char post[] = " a post of tiles in memory; in the store what is not 0";
	bool begun = false;
	char heals[120];
	print_aboard(scene, plan, &begun);
	print_effect(plan, EFFECT_THROWN, "thrown: rims that slip throw soil, which flies as grains and lands", bytes_of(&plan->plan, "grains in flight"), " for the most grains", &begun);
	if (scene->heals > 0) {
		snprintf(heals, sizeof heals, "disturbance: marks fade, the darkest in %g s", scene->heals);
		print_effect(plan, EFFECT_DISTURBANCE, heals, post_bytes(&plan->plan, scene_effect_row(EFFECT_DISTURBANCE)->name), post, &begun);
	}
	print_effect(plan, EFFECT_VEGETATION, "vegetation: plants are pressed and torn, rise and grow back", post_bytes(&plan->plan, scene_effect_row(EFFECT_VEGETATION)->name), post, &begun);
}
