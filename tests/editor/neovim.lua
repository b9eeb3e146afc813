-- Opens a controller in a headless Neovim, and writes what the language server shows as JSON.
local program, path, out = vim.env.TRACERISK, vim.env.CONTROLLER, vim.env.RESULT
vim.cmd("edit " .. vim.fn.fnameescape(path))
local buffer = vim.api.nvim_get_current_buf()
local client = vim.lsp.start_client({ name = "tracerisk", cmd = { program, "lsp" } })
vim.lsp.buf_attach_client(buffer, client)
local found = { messages = {} }

local function wait(condition)
  assert(vim.wait(30000, condition, 20), "nothing came in time")
end

local function ask(method, extra)
  local params = vim.tbl_extend("force", { textDocument = { uri = vim.uri_from_bufnr(buffer) } }, extra or {})
  local answer = vim.lsp.buf_request_sync(buffer, method, params, 30000)
  local one = answer and answer[client]
  assert(one and not one.err, vim.inspect(answer))
  return one.result
end

wait(function()
  return #vim.lsp.get_active_clients() == 1 and vim.lsp.get_client_by_id(client).initialized
end)

local line = vim.fn.search("^def act") - 1
found.hover = ask("textDocument/hover", { position = { line = line, character = 5 } }).contents.value
found.lenses = vim.tbl_map(function(each)
  return each.command.title
end, ask("textDocument/codeLens"))
found.foldings = #ask("textDocument/foldingRange")

-- What is typed and not saved is checked, and a fix puts it right again.
local at = vim.fn.search("quantity = 7") - 1
local typed = vim.api.nvim_buf_get_lines(buffer, at, at + 1, true)[1]
vim.api.nvim_buf_set_lines(buffer, at, at + 1, true, { (typed:gsub("7", "6")) })
wait(function()
  return #vim.diagnostic.get(buffer) > 0
end)
found.diagnostics = vim.tbl_map(function(each)
  return { each.lnum, each.code, each.severity }
end, vim.diagnostic.get(buffer))
local range = { start = { line = at, character = 0 }, ["end"] = { line = at, character = 0 } }
for _, action in ipairs(ask("textDocument/codeAction", { range = range, context = { diagnostics = {} } })) do
  if action.title:match("^Put ") then
    local encoding = vim.lsp.get_client_by_id(client).offset_encoding
    vim.lsp.util.apply_workspace_edit(action.edit, encoding)
  end
end
found.is_back = vim.api.nvim_buf_get_lines(buffer, at, at + 1, true)[1] == typed
wait(function()
  return #vim.diagnostic.get(buffer) == 0
end)

local file = assert(io.open(out, "w"))
file:write(vim.json and vim.json.encode(found) or vim.fn.json_encode(found))
file:close()
vim.cmd("qall!")
