/* The keys of furrow view: one table for what they do and for what is said of them. */

#include "view.h"

#define KEYS_MOST 6

static const struct binding {
	enum view_action action;
	int keys[KEYS_MOST]; /* 0: no more */
} bindings[] = {
	{VIEW_FORWARD, {'w', WINDOW_UP}},
	{VIEW_BACK, {'s', WINDOW_DOWN}},
	{VIEW_LEFT, {'a', WINDOW_LEFT}},
	{VIEW_RIGHT, {'d', WINDOW_RIGHT}},
	{VIEW_DOWN, {'q'}},
	{VIEW_UP, {'e'}},
	{VIEW_FOLLOW, {'f'}},
	{VIEW_RESET, {'r'}},
	{VIEW_PAUSE, {' '}},
	{VIEW_ONE_STEP, {'n', '.'}},
	{VIEW_SLOWER, {WINDOW_MINUS}},
	{VIEW_FASTER, {WINDOW_PLUS}},
	{VIEW_MARK, {'c'}},
	{VIEW_BACK_TO, {'z'}},
	{VIEW_SEND, {'t'}},
	{VIEW_GRAPH, {'g'}},
	{VIEW_MAP, {'m'}},
	{VIEW_DROP, {'o'}},
	{VIEW_SHAPE, {'b'}},
	{VIEW_LAYER, {'1', '2', '3', '4', '5', '6'}},
	{VIEW_SNAPSHOT, {'p'}},
	{VIEW_LINE, {'l'}},
	{VIEW_HELP, {'h'}},
	{VIEW_END, {WINDOW_ESCAPE}},
};

#define BINDINGS (sizeof bindings / sizeof *bindings)

#define LINES(line) \
	line("W A S D    fly, as the arrow keys do; Q down, E up; Shift: faster") \
	line("drag       look around with the left button held") \
	line("F          follow an object or vehicle; again: the next; at the end: fly") \
	line("R          the scene's own camera") \
	line("Space      pause, and go on") \
	line("N .        one step") \
	line("+ -        twice as fast, half as fast; at the top as fast as it can") \
	line("C Z        mark this moment; go back to it, with ground and vehicles") \
	line("click T    send the vehicle there, if it follows a path; T: to the cursor") \
	line("G          slip and sinkage of its wheels in the last 10 s") \
	line("M          a map with all ways; a click on it follows the nearest") \
	line("O          drop an object at the cursor; so does the right button") \
	line("B          what is dropped: the scene's first object, or a ball") \
	line("1 ... 6    colours: natural, offset, dirt, height, slope, tiles") \
	line("P          write view-NNNN.png") \
	line("L          the line of figures") \
	line("H          these keys") \
	line("Esc        end")
#define ENTRY(text) text,
#define TEXT(text) "  " text "\n"

static const char *const lines[] = {LINES(ENTRY)};
const char view_keys_text[] =
	"Needs a display. Looking changes nothing: ruts go to a temporary overlay, which is removed at the end; --overlay or --write keeps\n"
	"them. A note tells which ruts are there already. At the scene's end the window stays.\n"
	"Pictures go to view-NNNN.png in the present folder.\n"
	"Keys:\n" LINES(TEXT);

enum view_action view_action_of(int key, int *which)
{
	for (size_t i = 0; i < BINDINGS; i++)
		for (int k = 0; k < KEYS_MOST && bindings[i].keys[k] != 0; k++)
			if (bindings[i].keys[k] == key) {
				*which = k;
				return bindings[i].action;
			}
	return VIEW_NOTHING;
}

bool view_action_held(const struct window *window, enum view_action action)
{
	for (size_t i = 0; i < BINDINGS; i++)
		for (int k = 0; k < KEYS_MOST && bindings[i].action == action && bindings[i].keys[k] != 0; k++)
			if (window_held(window, bindings[i].keys[k]))
				return true;
	return false;
}

const char *view_help(size_t line)
{
	return line < sizeof lines / sizeof *lines ? lines[line] : NULL;
}
