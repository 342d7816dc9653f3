function oi = chart_image(varargin)
% The ColorChecker behind the lens; the argument is the fall-off of `lens`.
oi = oiCompute(lens(varargin{:}), chart_scene());
end
