/*
 * The crew: threads that compute contacts and regions of soil that bears which share no post. Its size changes no bit.
 *
 * A few bodies are computed sooner by one thread: to wake others takes longer than what they would save. So a world with few bodies has no crew, and where
 * there is one, little work stays with the thread that steps.
 */
#include "world/internal.h"

#define CREW_BODIES 8     /* a world with fewer bodies has no crew */
#define CREW_MOST 8       /* threads */
#define HANDS_EACH 8      /* groups or regions that wait for each thread */
#define POSTS_LEAST 16384 /* that are read; less is computed by one thread */

size_t world_crew_members(const struct world *world)
{
	const struct scene *scene = world->scene;
	const size_t bodies = scene->object_count + 4 * scene->vehicle_count;
	const int cores = world->params.threads > 0 ? world->params.threads : thread_cores();
	if (!world_is_bearing(world) || !world_feels(world) || (bodies < CREW_BODIES && world->params.threads == 0) || cores < 2)
		return 1;
	return cores < CREW_MOST ? (size_t)cores : CREW_MOST;
}

enum status world_crew_create(struct world *world)
{
	const size_t members = world->bearing != NULL ? world_crew_members(world) : 1;
	if (members < 2)
		return STATUS_OK;
	TRY(bearing_hands_need(world->bearing, HANDS_EACH * members));
	TRY(crew_create(members, WORLD_CREW_THREAD, NULL, NULL, &world->crew));
	world->hands = HANDS_EACH * members;
	return STATUS_OK;
}

void world_crew_plan(const struct world *world, struct plan *plan)
{
	const size_t members = world_crew_members(world);
	if (members > 1)
		plan_add(plan, &(struct plan_line){.kind = PLAN_THREAD, .object = -1, .amount = members - 1}, WORLD_CREW_THREAD);
}

size_t world_hands_for(const struct world *world, double posts)
{
	return world->crew != NULL && (posts >= POSTS_LEAST || world->params.threads > 0) ? world->hands : 1;
}

enum status world_crew_run(struct world *world, size_t count, crew_task_fn task, void *user)
{
	if (world->crew != NULL && count > 1)
		return crew_run(world->crew, count, task, user);
	for (size_t i = 0; i < count; i++)
		TRY(task(user, 0, i));
	return STATUS_OK;
}
