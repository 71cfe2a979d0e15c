/* Finds effects that a scene asks for and that nothing in it can show. These are thrown soil without a rim that slips, a sheet too stiff for its posts, and plants that no
 * picture has. */
#include <math.h>
#include <stdio.h>

#include "scene/scene.h"
#include "scene/scene_check.h"

/* Whether an object may turn: a wheel, a belt, or one whose path has attitudes. */
static bool may_turn(const struct scene_object *object)
{
	return object->shape.kind == SOIL_WHEEL || object->shape.belt || object->path.has_attitude || object->path.count == 0;
}

static void advise_thrown(const struct scene *scene, scene_advice_fn tell, void *user)
{
	bool turns = scene_moves_bodies(scene);
	for (size_t i = 0; i < scene->object_count && !turns; i++)
		turns = may_turn(&scene->objects[i]);
	if (scene->thrown == SCENE_THROWN_ON && (!turns || !scene_slips(scene)))
		tell(user, turns ? "redistribute.thrown: nothing slips, so nothing is thrown; give a wheel a slip, or take thrown away"
				 : "redistribute.thrown: rims that slip throw soil, and no object turns; add a wheel with a slip, or take thrown away");
}

static void advise_sheet(const struct scene *scene, double spacing, scene_advice_fn tell, void *user)
{
	const double length = sqrt(scene->tension / scene->stiffness);
	char text[300];
	if (!deform_is_elastic(scene->model) || !(spacing > 0) || length >= spacing)
		return;
	snprintf(text, sizeof text, "redistribute.stiffness: the sheet bends over %.3g m, and posts are %g m apart: beside a body it is level; give more tension, less stiffness, or a finer spacing",
		 length, spacing);
	tell(user, text);
}

void scene_advise_effects(const struct scene *scene, double spacing, scene_advice_fn tell, void *user)
{
	advise_thrown(scene, tell, user);
	advise_sheet(scene, spacing, tell, user);
	if (scene->vegetation.present && !scene->view.present && !scene->view.left_out)
		tell(user, "attributes.vegetation: no picture shows it: it is kept for export and for later drives that draw it; add a view, or take it away");
}
